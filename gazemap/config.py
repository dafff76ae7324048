"""Configuration: frozen records with defaults beside the field, and a strict TOML loader."""
