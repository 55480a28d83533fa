//! EliteScript: lexer, parser, resolver, tree-walking evaluator on coroutines, diagnostics.
