"""Figures of results: functions from a dataset to a matplotlib figure, or into the user's axes.

Nothing here computes physics, and nothing touches matplotlib's global figure list, so the
figures need no closing and can be drawn in any thread. Figures in the same style are made of
``sheet`` and ``grid``, with ``series_line`` for lines and ``series_handle`` for the legend. Names
are loaded when they are first used: matplotlib takes a while.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
