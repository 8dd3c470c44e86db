import numpy as np

import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/composite_fourbar.toml"), 4)
middle = flexmech.LinkPoint.parse("coupler:0.5")
request = flexmech.HammerRequest(np.radians([96.9]), impact=middle, response=middle, modes=3)
test = flexmech.hammer_test(engine, request)
print(test.summary())
test.plot().savefig("frf.png")
