"""A rigid-body engine of Sunder in Python: derive from Engine and call main(). rigid/README.md says what is promised.

The session, its checks and the connection are here; nothing beyond python3-protobuf and protoc is needed.
"""
from .engine import BAD_INPUT, ENGINE_FAILED, PEER_LOST, Engine, Refused
from .serve import main

__all__ = ["BAD_INPUT", "ENGINE_FAILED", "PEER_LOST", "Engine", "Refused", "main"]
