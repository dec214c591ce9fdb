"""Pictures of the engineering answers, a file each: workspace, sizing, retiming and so on, drawn by matplotlib."""
