import flexmech

mechanism = flexmech.load_mechanism("models/moist_composite_fourbar.toml")
water = flexmech.moisture_uptake(mechanism, relative_humidity=0.85, time=30 * 86400.0)
print(water.summary())
water.plot().savefig("moisture.png")
