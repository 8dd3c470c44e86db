from pathlib import Path

MODEL = (Path(__file__).parents[1] / "data" / "wet_four_bar.toml").read_text(encoding="utf-8")
