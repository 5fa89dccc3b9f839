"""`python -m arcsmith` is the program `arcsmith`."""

import sys

from ._program import main

sys.exit(main())
