"""Which scenarios a sweep has."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import find
from bt_mission.base.output import within
from bt_mission.commands.sweep.plan import SweepPlan
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, BaseScenario, load_base
from bt_mission.scenarios.concrete.bundle import Bundle
from bt_mission.scenarios.concrete.ranges import Interval, ValueChoice, parse_parameter
from bt_mission.scenarios.concrete.worker import ScenarioWorker

MISSION = """\
mission: m
world: empty_arena
seed: 5
inputs: {speed: 0.1, legs: 2}
tree: {wait: speed}
"""


@pytest.fixture
def base(tmp_path: Path) -> BaseScenario:
    """A mission in a file."""
    file = tmp_path / "m.yaml"
    file.write_text(MISSION)
    worlds = [ValueChoice("world", ("dqn_stage1", "empty_arena"))]
    return load_base(file, BaseChanges(), worlds)


def test_every_point_is_run_with_every_plan_and_every_seed(base: BaseScenario):
    """Seeds change last: a part of a sweep speaks of all points."""
    parameters = (
        ValueChoice("speed", (0.1, 0.2)),
        ValueChoice("world", ("dqn_stage1", "empty_arena")),
    )
    plans = {"none": [], "lost": ["at 1.0: drop scan lasting 1"]}
    plan = SweepPlan(base, parameters, seeds=(3, 4), plans=plans)
    assert plan.count == 16
    made = list(plan.scenarios())
    reports = [
        (each.data["seed"], each.plan, each.data["inputs"]["speed"], each.data["world"])
        for each in made
    ]
    assert reports[:4] == [
        (3, "none", 0.1, "dqn_stage1"),
        (3, "lost", 0.1, "dqn_stage1"),
        (3, "none", 0.1, "empty_arena"),
        (3, "lost", 0.1, "empty_arena"),
    ]
    assert len(set(reports)) == 16
    assert [scenario.number for scenario in made] == list(range(16))
    assert len({scenario.id for scenario in made}) == 16
    assert plan.scenario(1).data["faults"] == ["at 1.0: drop scan lasting 1"]


def test_without_a_word_it_is_the_mission_itself(base: BaseScenario):
    """With its own seed."""
    (scenario,) = SweepPlan(base).scenarios()
    assert scenario.data["seed"] == 5
    assert scenario.parameters == {}


def test_a_sample_is_evenly_spread_and_repeats(base: BaseScenario):
    """Each tenth of the interval has one of ten draws, which have seeds of their own."""
    parameters = (Interval("speed", 0.0, 1.0), ValueChoice("legs", (1, 2)))
    first, again, other = (
        list(SweepPlan(base, parameters, sample=10, sample_seed=seed).scenarios())
        for seed in (3, 3, 4)
    )
    tenths = sorted(int(scenario.parameters["speed"] * 10) for scenario in first)
    assert tenths == [scenario.data["seed"] for scenario in first] == list(range(10))
    assert [scenario.parameters["legs"] for scenario in first].count(1) == 5
    ids, same, different = ([scenario.id for scenario in made] for made in (first, again, other))
    assert ids == same
    assert ids != different


def test_draws_that_repeat_each_other_are_run_once(base: BaseScenario):
    """Five draws of two values with one seed are two scenarios."""
    plan = SweepPlan(base, (ValueChoice("legs", (1, 2)),), seeds=(0,), sample=5)
    assert len(list(plan.scenarios())) == 2


def test_an_interval_asks_for_a_sample(base: BaseScenario):
    """It has no end of values."""
    with pytest.raises(InputError, match="--sample N"):
        SweepPlan(base, (Interval("speed", 0.0, 1.0),))


def test_a_grid_of_a_milliard_is_counted_at_once(base: BaseScenario):
    """Nothing of it is made before it is wanted."""
    plan = SweepPlan(base, (ValueChoice("legs", (1, 2)),), seeds=range(500_000_000))
    assert plan.count == 1_000_000_000
    assert plan.scenario(999_999_999).data["seed"] == 499_999_999
    assert plan.about.seeds == "0..499999999"


def test_the_id_follows_from_all_that_a_run_follows_from(tmp_path: Path):
    """Files, seed, values, faults; not from where the files lie."""
    ids = []
    changes = [
        (MISSION, BaseChanges(), 1),
        (MISSION, BaseChanges(), 2),
        (MISSION, BaseChanges(set={"speed": "0.3"}), 1),
        (MISSION.replace("tree:", "tree: # a word\n "), BaseChanges(), 1),
        (MISSION, BaseChanges(faults=["at 1.0: drop scan lasting 1"]), 1),
        (MISSION, BaseChanges(world="dqn_stage1"), 1),
        (MISSION, BaseChanges(requirements={"slow": "always speed < 1"}), 1),
        (MISSION, BaseChanges(limit=9.0), 1),
        (MISSION, BaseChanges(), 1),
    ]
    for number, (text, change, seed) in enumerate(changes):
        file = tmp_path / str(number) / "m.yaml"
        file.parent.mkdir()
        file.write_text(text)
        ids.append(load_base(file, change).concrete({}, seed=seed).id)
    assert len(set(ids)) == len(ids) - 1
    assert ids[0] == ids[-1]


def test_a_world_of_the_users_own_has_its_file_in_the_bundle(tmp_path: Path):
    """Under its name, beside another of the same name."""
    file = tmp_path / "m.yaml"
    file.write_text(MISSION)
    for folder in ("a", "b"):
        world = tmp_path / folder / "hall.yaml"
        world.parent.mkdir()
        world.write_text(f"# {folder}\nname: hall\nsize: [4, 4]\n")
    texts = tuple(str(tmp_path / folder / "hall.yaml") for folder in ("a", "b"))
    base = load_base(file, BaseChanges(), [ValueChoice("world", texts)])
    assert [base.concrete({"world": text}).data["world"] for text in texts] == ["hall", "hall_2"]
    assert base.bundle.files["worlds/hall.yaml"].startswith("# a")
    assert base.bundle.files["worlds/hall_2.yaml"].startswith("# b")


def test_a_scenario_is_varied_as_a_mission_is(tmp_path: Path):
    """Its faults, obstacles and expectations stay."""
    (tmp_path / "m.yaml").write_text(MISSION)
    file = tmp_path / "s.scenario.yaml"
    file.write_text(
        "scenario: s\nmission: m.yaml\nworld: dqn_stage1\nseed: 9\ninputs: {legs: 3}\n"
        "faults: ['at 1.0: drop scan lasting 1']\nexpect: {outcome: failure}\n"
    )
    base = load_base(file, BaseChanges(faults=["at 2.0: drop odom lasting 1"]))
    scenario = base.concrete({"speed": 0.4})
    assert scenario.data["inputs"] == {"legs": 3, "speed": 0.4}
    assert scenario.data["faults"] == ["at 1.0: drop scan lasting 1", "at 2.0: drop odom lasting 1"]
    assert (scenario.data["seed"], scenario.data["world"]) == (9, "dqn_stage1")
    assert scenario.data["expect"] == {"outcome": "failure"}


def test_parameters_of_the_place_and_of_inputs(base: BaseScenario):
    """An input may have the name of a place."""
    made = base.concrete({"start.x": 1.0, "start.yaw": 90, "inputs.legs": 4})
    assert made.data["start"] == {"x": 1.0, "yaw": 90}
    assert made.data["inputs"]["legs"] == 4


def test_texts_of_parameters_name_the_sweep(base: BaseScenario):
    """So that the same command goes on, and another one is told what differs."""
    plan = SweepPlan(base, (parse_parameter("speed=0.1,0.2"),), seeds=range(3))
    assert plan.about.vary == ["speed=0.1,0.2"]
    assert plan.about.seeds == "0..2"


def test_robots_vary_by_name_and_by_file(tmp_path):
    """Each scenario runs with its own robot; the file goes with the mission to the workers."""
    own = tmp_path / "mine.yaml"
    text = Path("robots/rosbot.yaml").read_text(encoding="utf-8")
    own.write_text(text.replace("name: rosbot", "name: mine"), encoding="utf-8")
    path = tmp_path / "nap.yaml"
    path.write_text("mission: nap\nworld: empty_arena\ntree: {wait: 0.2}\n", encoding="utf-8")
    parameters = (parse_parameter(f"robot=husky,{own}"),)
    plan = SweepPlan(load_base(path, BaseChanges(), parameters), parameters, seeds=range(2))
    with ScenarioWorker(plan.base.bundle) as worker:
        robots = [worker.load(each).mission.robot for each in plan.scenarios()]
        rows = [worker.carry_out(each) for each in plan.scenarios()]
    assert [Path(robot).stem for robot in robots] == ["husky", "mine"] * 2
    ran = [(row.robot, row.seed) for row in rows if row.passed]
    assert ran == [("husky", 0), ("mine", 0), ("husky", 1), ("mine", 1)]


def test_a_mission_need_not_suit_a_robot_that_the_sweep_never_uses(tmp_path):
    """0.4 m/s is too fast for a Waffle, the robot of missions that name none."""
    path = tmp_path / "fast.yaml"
    path.write_text(
        "mission: fast\nworld: wide_arena\ntree:\n"
        "  explore_forward: {fwd_velocity: 0.4, stopping_distance: 0.5}\n  timeout: 30\n",
        encoding="utf-8",
    )
    base = load_base(path, BaseChanges(), (parse_parameter("robot=husky,rosbot"),))
    assert base.mission.robot == "husky"
    with pytest.raises(InputError, match="fwd_velocity must be from"):
        load_base(path, BaseChanges(), (parse_parameter("speed=0.1,0.2"),))


def test_the_model_of_a_robot_has_its_files_in_the_bundle(tmp_path: Path):
    """They lie beside the robot's file on each worker; another text for one name is refused."""
    (tmp_path / "m.yaml").write_text(MISSION)
    shipped = find("robots", "waffle_arm")
    base = load_base(tmp_path / "m.yaml", BaseChanges(), [ValueChoice("robot", ("waffle_arm",))])
    base.bundle.write_to(tmp_path / "worker")
    for name in ("waffle_arm.yaml", "waffle_arm.xml"):
        assert (tmp_path / "worker/robots" / name).read_bytes() == (
            shipped.with_name(name).read_bytes()
        )
    mine = tmp_path / "mine/arm.yaml"
    mine.parent.mkdir()
    mine.write_text(shipped.read_text())
    (mine.parent / "waffle_arm.xml").write_text("<mujoco/>")
    with pytest.raises(BtMissionError, match=r"different files named robots/waffle_arm\.xml"):
        load_base(
            tmp_path / "m.yaml", BaseChanges(), [ValueChoice("robot", ("waffle_arm", str(mine)))]
        )


# ---- the files of a bundle, which comes from others ------------------------------------------


@pytest.mark.parametrize("name", ["../x", "a/../../x", "/etc/x", ""])
def test_a_name_that_leads_out_is_refused(tmp_path, name):
    """A name inside is a path, whether there is a file or not."""
    assert within(tmp_path, "missions/go.yaml") == tmp_path / "missions" / "go.yaml"
    with pytest.raises(BtMissionError, match="is outside the folder"):
        within(tmp_path, name)
    with pytest.raises(BtMissionError):
        Bundle({name: "x"}, "m", {}, {}).write_to(tmp_path)


@pytest.mark.parametrize("link", ["missions", "missions/go.yaml"])
def test_a_link_on_the_way_is_refused(tmp_path, link):
    """Nothing is written where it leads to."""
    folder, victim = tmp_path / "results", tmp_path / "victim"
    victim.mkdir()
    path = folder / link
    path.parent.mkdir(parents=True)
    path.symlink_to(victim if link == "missions" else victim / "file")
    with pytest.raises(BtMissionError, match="a symbolic link"):
        Bundle({"missions/go.yaml": "x"}, "missions/go.yaml", {}, {}).write_to(folder)
    assert list(victim.iterdir()) == []
