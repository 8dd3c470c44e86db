import flexmech

mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
request = flexmech.KinematicsRequest(crank_speed=20.0, lumped=(1, 4, 4))
result = flexmech.kinematics(mechanism, request)
print(result.summary())
result.plot().savefig("kinematics.png")
