"""Takes a managed node through its states."""

import time

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node
from std_msgs.msg import Int32


class Manager(Node):
    def __init__(self):
        super().__init__("manager")
        self.change = self.create_client(ChangeState, "managed/change_state")
        self.get = self.create_client(GetState, "managed/get_state")
        self.create_subscription(Int32, "managed_count", lambda m: print("count", m.data), 10)
        self.change.wait_for_service()
        self.get.wait_for_service()

    def ask(self, client, request):
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def go(self, transition):
        request = ChangeState.Request(transition=Transition(id=transition))
        done = self.ask(self.change, request).success
        state = self.ask(self.get, GetState.Request()).current_state.label
        print(transition, done, state)

    def wait(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            rclpy.spin_once(self, timeout_sec=left)


rclpy.init()
manager = Manager()
print("go")
for transition in (
    Transition.TRANSITION_CONFIGURE,
    Transition.TRANSITION_ACTIVATE,
    Transition.TRANSITION_DEACTIVATE,
    Transition.TRANSITION_CLEANUP,
):
    manager.go(transition)
    manager.wait(0.9)
rclpy.shutdown()
