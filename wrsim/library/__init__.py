"""The contact as a C library for other programs (docs/user/library.md): its source and its build."""
