import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)
run = flexmech.response(engine, 190, revolutions=0.25, samples=120, speed_unit="rpm")
print(run.summary())
run.plot(links="coupler").savefig("coupler.png")
run.save("results")
