"""Makes the modules of `data/concealed/generate` importable: structures, laws, plans, clock, information."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]
ROOT = HERE.parents[1]
CONCEALED = ROOT / "data" / "concealed"
if str(CONCEALED / "generate") not in sys.path:
    sys.path.append(str(CONCEALED / "generate"))  # behind this folder: `generate.py` exists in both
sys.path.append(str(HERE))  # judge.py
