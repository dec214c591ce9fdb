"""Pages of the site that are made of something else than a document, and what documents need to become pages."""
