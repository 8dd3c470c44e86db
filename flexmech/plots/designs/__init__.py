"""Pictures of studies: designs over what varies, shares of inputs, and the best of them."""
