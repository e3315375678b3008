"""Contacts of prescribed poses."""
