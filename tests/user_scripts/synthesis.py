import numpy as np

import flexmech

design = flexmech.crank_rocker_synthesis(np.radians(30), np.radians(90), ground=0.4)
print(design.summary())
design.plot().savefig("transmission_angle.png")
