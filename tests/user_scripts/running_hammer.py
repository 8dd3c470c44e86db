import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)
hit, seen = map(flexmech.LinkPoint.parse, ("coupler:0.5", "rocker:0.5"))
asked = {"prestress": "axial", "damping_ratio": 0.1, "bandwidth": 60.0, "orders": 1}
test = flexmech.running_hammer_test(engine, speed=20.0, impact=hit, response=seen, **asked)
print(test.summary())
test.plot().savefig("harmonic_frf.png")
