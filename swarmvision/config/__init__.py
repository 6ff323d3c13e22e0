"""Every setting and every default: frozen pydantic models, TOML in, JSON Schema out."""
