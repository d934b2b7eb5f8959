"""CDR, the wire format of DDS: read, write and decode messages without generated code."""
