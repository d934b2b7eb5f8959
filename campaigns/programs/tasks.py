"""Tasks of an executor: coroutines that await a service, a timer, and each other."""

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future


class Tasks(Node):
    def __init__(self):
        super().__init__("tasks")
        self.client = self.create_client(AddTwoInts, "add")
        self.client.wait_for_service()

    async def sleep(self, seconds):
        done = Future()
        timer = self.create_timer(seconds, lambda: done.set_result(None))
        await done
        self.destroy_timer(timer)

    async def add(self, a, b):
        answer = await self.client.call_async(AddTwoInts.Request(a=a, b=b))
        print("sum", answer.sum)
        return answer.sum

    async def all(self):
        total = 0
        for number in range(3):
            total += await self.add(number, 1)
            await self.sleep(0.3)
        return total


rclpy.init()
node = Tasks()
executor = SingleThreadedExecutor()
executor.add_node(node)
print("go")
task = executor.create_task(node.all())
executor.spin_until_future_complete(task)
print("total", task.result())
failing = executor.create_task(lambda: 1 / 0)
try:
    executor.spin_until_future_complete(failing)
except ZeroDivisionError:
    print("raised")
rclpy.shutdown()
