import flexmech

mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
check = flexmech.check_mechanism(mechanism)
print(check.summary())
check.plot().savefig("linkage.png")
print(mechanism.to_toml())
