import numpy as np

import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)
speeds = np.linspace(86.0, 88.0, 3)
stability = flexmech.stability(engine, speeds, prestress="axial", modes=2, damping_ratio=0.01)
print(stability.summary())
stability.plot().savefig("stability.png")
