import numpy as np

import flexmech

mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
engines = [flexmech.ReferenceEngine(mechanism, 4), flexmech.ExudynEngine(mechanism, 4)]
result = flexmech.moving_frequencies(engines, np.radians([0, 60, 120]), [0, 20], modes=2)
print(result.summary())
result.plot(modes=1, engine="reference").savefig("mode_1.png")
result.save("results", figures=True)
