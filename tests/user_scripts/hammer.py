import numpy as np

import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/composite_fourbar.toml"), 4)
middle = flexmech.LinkPoint.parse("coupler:0.5")
test = flexmech.hammer_test(engine, np.radians([96.9]), impact=middle, modes=3)
print(test.summary())
test.plot().savefig("frf.png")
