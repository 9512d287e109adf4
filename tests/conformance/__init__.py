"""The conformance suite, called for every engine."""
