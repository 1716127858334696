import { defineConfig } from 'vite';

// Static files that lie anywhere: addresses are relative, and nothing is inlined that the content security policy
// would refuse.
export default defineConfig({
  base: './',
  build: { target: 'es2023', assetsInlineLimit: 0, modulePreload: { polyfill: false }, chunkSizeWarningLimit: 1000 },
  worker: { format: 'es' },
  optimizeDeps: { exclude: ['@articula/core', '@articula/three'] },
});
