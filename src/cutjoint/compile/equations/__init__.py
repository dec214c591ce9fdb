"""The equations of motion of a closed robot as expressions."""
