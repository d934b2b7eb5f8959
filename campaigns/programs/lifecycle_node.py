"""A managed node, whose publisher is silent until it is active."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, State, TransitionCallbackReturn
from std_msgs.msg import Int32


class Managed(LifecycleNode):
    def __init__(self):
        super().__init__("managed")
        self.publisher = self.timer = None
        self.count = 0

    def tick(self):
        self.count += 1
        self.publisher.publish(Int32(data=self.count))

    def on_configure(self, state: State):
        print("configures from", state.label)
        self.publisher = self.create_lifecycle_publisher(Int32, "managed_count", 10)
        self.timer = self.create_timer(0.25, self.tick)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: State):
        print("activates")
        return super().on_activate(state)

    def on_deactivate(self, state: State):
        print("deactivates")
        return super().on_deactivate(state)

    def on_cleanup(self, state: State):
        print("cleans up")
        self.destroy_timer(self.timer)
        self.destroy_publisher(self.publisher)
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: State):
        print("shuts down")
        return TransitionCallbackReturn.SUCCESS


rclpy.init()
try:
    rclpy.spin(Managed())
except (KeyboardInterrupt, ExternalShutdownException):
    print("ends")
