"""Questions put to a mechanism or to engines; each answer is a result.

A folder a question: what can be asked (request), how it is computed, and the result with its
tables, pictures and summary. Names are loaded when they are first used. The functions ``balance``,
``campbell``, ``kinematics``, ``response``, ``stability`` and ``strength`` are
named like their folders: they are in ``compute`` of the folders, and in ``flexmech``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
