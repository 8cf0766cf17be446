"""Write the JSON schema of a config: ``python -m undertow.campaign.config``."""

from pathlib import Path

from undertow.campaign.config.run_config import write_schema

if __name__ == "__main__":
    write_schema(Path("configs") / "run.schema.json")
