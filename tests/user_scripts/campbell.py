import numpy as np

import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)
diagram = flexmech.campbell(engine, np.linspace(0.0, 30.0, 4), orders=[9, 10], modes=2)
print(diagram.summary())
diagram.plot().savefig("campbell.png")
