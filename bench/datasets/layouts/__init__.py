"""The layouts, one file each: a module with ``LAYOUTS``, names to `bench.datasets.layout.Layout`."""
