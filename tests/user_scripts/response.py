import flexmech

engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)
drive = flexmech.CrankDrive(20.0)
run = flexmech.response(engine, flexmech.ResponseRequest(drive, revolutions=0.25, samples=120))
print(run.summary())
run.plot(links="coupler").savefig("coupler.png")
run.save("results")
