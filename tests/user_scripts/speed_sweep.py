import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)
sweep = flexmech.speed_sweep(engine, [10.0, 20.0], modes=2)
print(sweep.summary())
sweep.plot(links="coupler").savefig("critical_speeds.png")
