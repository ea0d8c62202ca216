"""Generated from proto/bendtwin/v1 by client/python/generate. Do not edit."""
