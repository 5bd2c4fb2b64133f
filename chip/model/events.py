"""The queue of what happens at a time: a byte that ends, a timer that expires, an oscillator that is stable."""

import heapq
import itertools


class Event:
    """What is due; `cancel` takes it back."""

    __slots__ = ("time", "call")

    def __init__(self, time, call):
        self.time = time
        self.call = call

    def cancel(self):
        self.call = None


class Events:
    """Events in the order of their times; of equal times the first that was asked for."""

    def __init__(self):
        self.heap = []
        self.order = itertools.count()

    def at(self, time, call):
        event = Event(time, call)
        heapq.heappush(self.heap, (time, next(self.order), event))
        return event

    def next_time(self):
        """Time of the next event, or None."""
        while self.heap and self.heap[0][2].call is None:
            heapq.heappop(self.heap)
        return self.heap[0][0] if self.heap else None

    def run_until(self, now):
        """Calls what is due."""
        while (time := self.next_time()) is not None and time <= now:
            call = heapq.heappop(self.heap)[2].call
            call()

    def clear(self):
        self.heap.clear()
