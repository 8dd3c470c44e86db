import numpy as np

import flexmech

mechanism = flexmech.load_mechanism("models/moist_composite_fourbar.toml")
engine = flexmech.ReferenceEngine(mechanism, 2)
state = flexmech.HygrothermalState(temperature_rise=60.0, moisture=0.04)
result = flexmech.moving_frequencies(engine, np.radians([0, 90]), [0.0], environment=state)
print(result.summary())
result.plot().savefig("dry_and_wet.png")
