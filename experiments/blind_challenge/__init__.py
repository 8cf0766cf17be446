"""A blind challenge: sealed campaigns drawn by chance, run as a laboratory would, scored against a truth that the
runner never saw.

`truths` makes motions, `effects` and its tables say what can be missing, `rigs` draws laboratories, `strength` measures
how visible an effect is, `cases`, `laboratory` and `generate` write them. `run_cases` and `peers` see the laboratories
alone; `judge`, `score`, `page` open the truths. Nothing here but the runner's call of `python -m undertow` knows of the
package.
"""
