"""Flexible linkages: moving natural frequencies and response, by two independent engines.

Names are loaded when they are first used, so that ``import flexmech`` and the command line's help
wait for no library.

Examples
--------
>>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
>>> result = flexmech.moving_frequencies(mechanism, np.radians([0, 60, 120]), [0, 20])
>>> result.dataset["frequency"].shape
(1, 2, 3, 4)

``result.plot()`` gives a matplotlib figure, ``result.save(folder)`` writes files and
``print(result.summary())`` prints the answer. A mechanism gets the reference engine; others are
``flexmech.ReferenceEngine(mechanism, elements=16)`` and ``flexmech.ExudynEngine(mechanism)``. Crank
speeds are in rad/s, or in the unit that is given beside them: ``speed_unit="rpm"``.
"""

import lazy_loader

__version__ = "0.1.0"

# The names and where they live stand in __init__.pyi, which type checkers read as well.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
