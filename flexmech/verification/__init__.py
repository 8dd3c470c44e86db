"""Cases that show on a user's own machine that flexmech computes what it should.

Each case sets numbers that flexmech computes beside published ones, those of other programs, closed
forms, or those of the other engine. The cases are files in the folder ``data``: the command
``flexmech verify``, the tests and the documentation read the same ones. Names are loaded when they
are first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
