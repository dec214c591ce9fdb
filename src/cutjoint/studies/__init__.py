"""Studies: many runs over any parameters, by a file, on all cores or a Dask cluster, streamed and resumed."""
