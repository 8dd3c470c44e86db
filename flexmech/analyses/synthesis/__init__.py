"""Which crank-rocker has the transmission angle that is wanted."""
