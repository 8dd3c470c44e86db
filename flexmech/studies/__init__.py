"""Studies of many designs of a linkage: sweeps, uncertainty, and the search for the best.

Names are loaded when they are first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
