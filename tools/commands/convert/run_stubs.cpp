// Runs one tree in BehaviorTree.CPP 4 with leaves that only pretend: tools/commands/convert/compare_btcpp.py.
//
// Usage: run_stubs TREE.xml MODEL.tsv MAIN_TREE SEED
//
// MODEL.tsv has a line for each port of each leaf, and for each input of the main tree:
//   port   LEAF  NAME  in|out  TYPE
//   leaf   LEAF
//   input  NAME  TYPE  VALUE
// Prints a line for each leaf that ends or is halted, and the status of the tree.

#include <cstdint>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <behaviortree_cpp/bt_factory.h>

namespace
{
constexpr int kMostTicks = 20000;

struct Port
{
  std::string name, direction, type;
};

std::uint64_t hash_of(const std::string& text)
{
  std::uint64_t value = 14695981039346656037ull;  // FNV-1a, 64 bits
  for(unsigned char c : text)
  {
    value = (value ^ c) * 1099511628211ull;
  }
  return value;
}

// What a leaf does the nth time: the same rule as in tools/commands/convert/compare_btcpp.py.
struct Rule
{
  bool fails;
  int ticks;
  double number;
};

Rule rule_of(const std::string& seed, const std::string& leaf, int count)
{
  const auto value = hash_of(seed + "/" + leaf + "/" + std::to_string(count));
  const bool never_fails = seed == "0" || leaf.rfind("log ", 0) == 0 || leaf.rfind("set ", 0) == 0 ||
                           leaf.rfind("wait ", 0) == 0;
  return { !never_fails && (value >> 8) % 100 < 25, static_cast<int>((value >> 20) % 40),
           static_cast<double>((value >> 32) % 181) - 90.0 };
}

std::map<std::string, int> counts;
std::string seed;

class Stub : public BT::StatefulActionNode
{
public:
  Stub(const std::string& name, const BT::NodeConfig& config, const std::vector<Port>& ports)
    : StatefulActionNode(name, config), ports_(ports)
  {}

  BT::NodeStatus onStart() override
  {
    leaf_ = registrationName() + " " + name();
    rule_ = rule_of(seed, leaf_, counts[leaf_]++);
    readInputs();
    writeOutputs();  // a leaf that is halted has given something, too
    return onRunning();
  }

  BT::NodeStatus onRunning() override
  {
    if(rule_.ticks-- > 0)
    {
      return BT::NodeStatus::RUNNING;
    }
    std::cout << leaf_ << (rule_.fails ? " FAILURE" : " SUCCESS") << "\n";
    return rule_.fails ? BT::NodeStatus::FAILURE : BT::NodeStatus::SUCCESS;
  }

  void onHalted() override
  {
    std::cout << leaf_ << " HALTED\n";
  }

private:
  template <typename T>
  void read(const std::string& port)
  {
    if(const auto found = getInput<T>(port); !found)
    {
      throw BT::RuntimeError(leaf_, ": ", port, ": ", found.error());
    }
  }

  void readInputs()
  {
    for(const auto& port : ports_)
    {
      const auto given = config().input_ports.find(port.name);
      if(port.direction != "in" || given == config().input_ports.end())
      {
        continue;
      }
      if(port.type == "double") read<double>(port.name);
      else if(port.type == "int") read<int>(port.name);
      else if(port.type == "bool") read<bool>(port.name);
      else if(port.type == "std::string") read<std::string>(port.name);
      if(port.name.rfind("set_", 0) == 0)
      {
        config().blackboard->set(port.name.substr(4), 1.0);
      }
    }
  }

  void writeOutputs()
  {
    for(const auto& port : ports_)
    {
      if(port.direction != "out" || config().output_ports.count(port.name) == 0)
      {
        continue;
      }
      if(port.type == "double") setOutput(port.name, rule_.number);
      else if(port.type == "int") setOutput(port.name, static_cast<int>(rule_.number));
      else if(port.type == "bool") setOutput(port.name, rule_.number > 0);
      else if(port.type == "std::string") setOutput(port.name, std::string("text"));
      else setOutput(port.name, BT::Any(rule_.number));
    }
  }

  const std::vector<Port> ports_;
  std::string leaf_;
  Rule rule_{ false, 0, 0.0 };
};

BT::PortsList::value_type info_of(const Port& port)
{
  const bool out = port.direction == "out";
  const auto make = [&](auto sample) {
    using T = decltype(sample);
    return out ? BT::OutputPort<T>(port.name) : BT::InputPort<T>(port.name);
  };
  if(port.type == "double") return make(0.0);
  if(port.type == "int") return make(0);
  if(port.type == "bool") return make(false);
  if(port.type == "std::string") return make(std::string());
  return out ? BT::OutputPort<BT::AnyTypeAllowed>(port.name) :
               BT::InputPort<BT::AnyTypeAllowed>(port.name);
}

void put(BT::Blackboard& board, const std::string& name, const std::string& type,
         const std::string& value)
{
  if(type == "double") board.set(name, std::stod(value));
  else if(type == "int") board.set(name, std::stoi(value));
  else if(type == "bool") board.set(name, value == "true");
  else board.set(name, value);
}

int run(char** arguments)
{
  std::map<std::string, std::vector<Port>> leaves;
  auto board = BT::Blackboard::create();
  std::ifstream model(arguments[2]);
  for(std::string line; std::getline(model, line);)
  {
    std::vector<std::string> words;
    std::stringstream stream(line + "\t");
    for(std::string word; std::getline(stream, word, '\t');)
    {
      words.push_back(word);
    }
    if(words.at(0) == "leaf") leaves[words.at(1)];
    else if(words.at(0) == "input") put(*board, words.at(1), words.at(2), words.at(3));
    else leaves[words.at(1)].push_back({ words.at(2), words.at(3), words.at(4) });
  }
  BT::BehaviorTreeFactory factory;
  for(const auto& [id, ports] : leaves)
  {
    BT::TreeNodeManifest manifest;
    manifest.type = BT::NodeType::ACTION;
    manifest.registration_ID = id;
    for(const auto& port : ports)
    {
      manifest.ports.insert(info_of(port));
    }
    factory.registerBuilder(manifest, [ports = ports](const std::string& name,
                                                      const BT::NodeConfig& config) {
      return std::make_unique<Stub>(name, config, ports);
    });
  }
  factory.registerBehaviorTreeFromFile(arguments[1]);
  seed = arguments[4];
  auto tree = factory.createTree(arguments[3], board);
  auto status = BT::NodeStatus::RUNNING;
  for(int tick = 0; status == BT::NodeStatus::RUNNING && tick < kMostTicks; tick++)
  {
    status = tree.tickExactlyOnce();
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  std::cout << "tree " << BT::toStr(status) << "\n";
  return 0;
}
}  // namespace

int main(int count, char** arguments)
{
  if(count != 5)
  {
    std::cerr << "usage: run_stubs TREE.xml MODEL.tsv MAIN_TREE SEED\n";
    return 2;
  }
  try
  {
    return run(arguments);
  }
  catch(const std::exception& error)
  {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
