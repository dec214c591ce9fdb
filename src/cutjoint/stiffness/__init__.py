"""Stiffness at the tool of closed robots whose actuators, joints and rods give way, and deflection under load."""
