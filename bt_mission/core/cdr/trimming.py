"""What rclpy adds to a message when it serializes it, taken away.

``serialize_message`` gives as many bytes as ROS has reckoned that a message may take. That is too
many where a sequence is empty whose elements would have to lie at multiples of eight, and readers
that check refuse such messages. What comes by DDS has its true length.
"""

from __future__ import annotations

from collections.abc import Callable

from bt_mission.core.cdr.decoder import Decoder

Take = Callable[[bytes], None]


class Trim:
    """Trims messages of one type.

    :param decoder: finds the end of a message, which takes as long as reading it.
    :param has_one_shape: messages of the same length as reckoned have the same true length, so
        each length is looked at once.
    """

    def __init__(self, decoder: Decoder, *, has_one_shape: bool) -> None:
        self._decoder = decoder
        self._has_one_shape = has_one_shape

    def before(self, take: Take) -> Take:
        """``take``, with messages trimmed."""
        if self._decoder.has_known_length:
            return take
        trim = self._decoder.trim
        if not self._has_one_shape:
            return lambda data: take(trim(data))
        lengths: dict[int, int] = {}

        def trimmed(data: bytes) -> None:
            length = lengths.get(len(data))
            if length is None:
                length = lengths[len(data)] = len(trim(data))
            take(data[:length])

        return trimmed
