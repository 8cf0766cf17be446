"""Work on several processes: order, errors, a worker that dies, and signals put back as they were."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from undertow.campaign.run.workers import on_processes
from undertow.errors import RecordingError, UndertowError


def square(number: int) -> int:
    return number * number


def refuse(number: int) -> int:
    if number == 2:
        raise RecordingError("trial 2 is no trial; leave it out")
    return number


def die(number: int) -> int:
    if number == 1:
        os._exit(9)
    return number


def interrupt_handling(_: int) -> bool:
    return signal.getsignal(signal.SIGINT) is signal.SIG_IGN


@pytest.mark.parametrize("jobs", [1, 2, 0])
def test_results_stand_in_the_items_order_whatever_the_processes(jobs: int) -> None:
    seen: list[tuple[str, int, int]] = []
    assert on_processes(square, [3, 1, 2, 5], jobs, "squares", lambda *p: seen.append(p)) == [9, 1, 4, 25]
    assert seen == [("squares", done, 4) for done in range(5)]


def test_nothing_to_do_is_done() -> None:
    assert on_processes(square, [], 2, "squares") == []


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_of_one_item_comes_through_as_it_is(jobs: int) -> None:
    with pytest.raises(RecordingError, match="trial 2 is no trial; leave it out"):
        on_processes(refuse, [0, 1, 2, 3], jobs, "refusing")


def test_a_worker_that_the_system_ends_is_said_with_the_way_on() -> None:
    with pytest.raises(UndertowError, match=r"dying: the system ended a worker process after \d of 4 items .*--jobs 1"):
        on_processes(die, [0, 1, 2, 3], 2, "dying")
    assert on_processes(square, [1, 2, 3], 2, "squares") == [1, 4, 9], "the next work has workers again"


def test_workers_ignore_an_interruption_and_this_process_does_not() -> None:
    before = signal.getsignal(signal.SIGINT)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [])
    # three: on two, these workers may be those of an earlier test, which must ignore it as well
    assert all(on_processes(interrupt_handling, [1, 2, 3, 4], 3, "asking"))
    assert signal.getsignal(signal.SIGINT) is before
    assert signal.pthread_sigmask(signal.SIG_BLOCK, []) == mask


def test_outside_the_main_thread_it_works_too() -> None:
    found: list[int] = []
    thread = threading.Thread(target=lambda: found.extend(on_processes(square, [1, 2, 3], 2, "squares")))
    thread.start()
    thread.join()
    assert found == [1, 4, 9]
