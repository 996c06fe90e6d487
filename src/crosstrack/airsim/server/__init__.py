"""The server: AirSim's protocol on one side, the embedded simulator on the other."""
