#!/bin/sh
# One searchable site of README.md, docs, gallery and what they link to, which needs no network: target/site/index.html.
. "$(dirname "$0")/prepare.sh"
bring site scripts/site-requirements.txt
python scripts/docs_site.py target/site
echo "open target/site/index.html"
