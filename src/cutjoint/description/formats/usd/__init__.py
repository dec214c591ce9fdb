"""USD, the format of Isaac Sim and of film: what UsdPhysics says of bodies and joints, read only."""
