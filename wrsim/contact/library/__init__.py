"""The contact (docs/user/library.md) and vehicles (docs/user/cosimulation.md) as C libraries: sources and build."""
