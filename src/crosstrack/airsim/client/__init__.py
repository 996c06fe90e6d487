"""A client of AirSim's protocol that needs no other package: blocking, or for asyncio."""
