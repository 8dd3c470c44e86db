import numpy as np

import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)
angle = np.radians([0.0, 90.0, 180.0, 270.0])
measured = np.array([43.9, 44.3, 44.6, 44.2])  # Hz, of the first mode
frequency = flexmech.MeasuredQuantity("frequency", "Hz", measured)
record = flexmech.MeasuredRecord("crank_angle", angle, (frequency,))
request = flexmech.ComparisonRequest(speed=0.0, fit=("stiffness:coupler",))
comparison = flexmech.compare_with_record(engine, record, request)
print(comparison.summary())
print(comparison.fitted("stiffness:coupler"))
comparison.plot().savefig("comparison.png")
