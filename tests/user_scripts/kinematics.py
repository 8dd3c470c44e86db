import flexmech

mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
result = flexmech.kinematics(mechanism, 20.0, lumped=(1, 4, 4))
print(result.summary())
result.plot().savefig("kinematics.png")
