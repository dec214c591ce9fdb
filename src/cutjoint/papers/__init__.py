"""Published reduced models, a folder each.  They know nothing of Pinocchio or of a robot's description on disk."""
