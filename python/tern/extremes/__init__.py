"""./tern extremes: where the method holds and how it fails, one short real run per cell."""
