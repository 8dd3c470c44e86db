"""A signal is answered even if it does not wake the program that waits for its processes."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time

import pytest

from flexmech.analyses.stability.parallel import in_order


@pytest.mark.skipif(
    sys.platform != "linux" or len(os.sched_getaffinity(0)) < 2, reason="one process does it all"
)
def test_a_signal_that_another_thread_takes_ends_the_wait() -> None:
    def late() -> None:
        time.sleep(0.5)
        # Taken by this thread, it does not interrupt the wait of the main thread.
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)

    since = time.monotonic()
    threading.Thread(target=late).start()
    with pytest.raises(KeyboardInterrupt):
        list(in_order(time.sleep, [25.0] * 3))
    assert time.monotonic() - since < 20
