# Which counterweights keep a four-bar from shaking its frame, and what do they cost?
import flexmech

mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
result = flexmech.balance(
    mechanism, 190.0, radii=(0.04, 0.06), speed_unit="rpm", full=True, rigid=True
)
print(result.summary())
result.save("results")  # the balanced model file among them
result.plot().savefig("balance.png")
