import numpy as np

import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)
measured = flexmech.MeasuredQuantity("frequency", "Hz", np.array([43.9, 44.3, 44.6, 44.2]))
angle = np.radians([0.0, 90.0, 180.0, 270.0])
record = flexmech.MeasuredRecord("crank_angle", angle, (measured,))
comparison = flexmech.compare_with_record(engine, record, speed=0.0, fit=["stiffness:coupler"])
print(comparison.summary())
comparison.plot().savefig("comparison.png")
